"""The report of a comparison: a page, numbers for programs, a summary for the terminal."""
