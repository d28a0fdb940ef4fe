"""The report of a run: one self-contained HTML file with plots, from a sheet, its inputs and its outputs.

import saoflow
from saoflow.report import RunShown, report_of_run, write_report

sheet = saoflow.load("cmhe_fte")
outputs = sheet.simulator().run(inputs)
write_report("report.html", report_of_run(sheet, inputs, outputs, time))
"""

from saoflow.report.contents import Difference, Fact, Limits, Mark, Report, RunShown, TextTable
from saoflow.report.page import limits_of, render_report, report_of_budget, report_of_run, write_report

__all__ = [
    "Difference",
    "Fact",
    "Limits",
    "Mark",
    "Report",
    "RunShown",
    "TextTable",
    "limits_of",
    "render_report",
    "report_of_budget",
    "report_of_run",
    "write_report",
]
