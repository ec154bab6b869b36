"""What people get to read: feedback pages, the class report, marking sheets, exports."""
