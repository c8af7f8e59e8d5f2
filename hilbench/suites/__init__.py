"""The suites that come with hilbench, one file each; `hilbench.check.cases` says how a suite is written."""
