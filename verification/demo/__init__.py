"""The demonstration: Fig. 4 of paper 004 flown by the sheets, from YAML to a report.

from verification.demo import Scenario, run_demo, write_files

result = run_demo(Scenario(seed=1))
write_files(result, "out")
"""

from verification.demo.files import write_files
from verification.demo.result import DemoResult, Method
from verification.demo.run import run_demo
from verification.demo.scenario import Scenario

__all__ = ["DemoResult", "Method", "Scenario", "run_demo", "write_files"]
