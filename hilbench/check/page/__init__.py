"""A run, or several beside each other, as one HTML file that needs nothing else."""

from __future__ import annotations

from hilbench.check.page.runs import Run, run_of_journal, run_of_report
from hilbench.check.page.writing import html_page

__all__ = ["Run", "html_page", "run_of_journal", "run_of_report"]
