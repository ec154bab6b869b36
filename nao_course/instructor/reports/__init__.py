"""What people get to read: feedback pages, the class report, marking sheets, exports."""

__all__: list[str] = [
    "class_report",
    "exports",
    "feedback",
    "html",
    "marking_sheets",
    "platforms",
    "spreadsheets",
]
