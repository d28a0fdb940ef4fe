"""Recordings: tables of frames in files, CSV (also gzip-compressed) or Parquet, one row a frame.

A scalar port ``vg`` is the column ``vg``; a vector ``alpha`` of size 3 is ``alpha_1, alpha_2, alpha_3``; a matrix ``P``
is ``P_1_1, P_1_2, ...``. Further columns are ignored, but ``t``, which is copied through. NaN, infinity and an empty
cell are missing samples: they run, and are counted.
"""

from saoflow.recordings.frames import (
    FrameReader,
    Frames,
    column_names,
    output_columns,
    read_frames,
    read_table,
)
from saoflow.recordings.output import (
    Output,
    TableWriter,
    check_output,
    check_place,
    csv_text,
    open_table,
    write_table,
)
from saoflow.recordings.table import Table

__all__ = [
    "FrameReader",
    "Frames",
    "Output",
    "Table",
    "TableWriter",
    "check_output",
    "check_place",
    "column_names",
    "csv_text",
    "open_table",
    "output_columns",
    "read_frames",
    "read_table",
    "write_table",
]
