"""The tables of a journal, and what each version of them added."""

from __future__ import annotations

VERSION = 4
APPLICATION = 0x4E414F4A  # "NAOJ": distinguishes this file from other SQLite files
RESULT_COLUMNS = "student, lesson, submission, assignment, status, level, seconds, versions, time, result"
VERSION_1 = f"""
CREATE TABLE results (
    student TEXT NOT NULL, lesson TEXT NOT NULL, submission TEXT NOT NULL, assignment TEXT NOT NULL,
    status TEXT NOT NULL, level TEXT NOT NULL, seconds REAL NOT NULL, versions TEXT NOT NULL, time TEXT NOT NULL,
    result TEXT NOT NULL, again INTEGER NOT NULL DEFAULT 0, PRIMARY KEY (student, lesson));
CREATE TABLE history AS SELECT {RESULT_COLUMNS} FROM results;
CREATE TABLE overrides (
    student TEXT NOT NULL, lesson TEXT NOT NULL, exercise TEXT NOT NULL, points REAL NOT NULL, reason TEXT NOT NULL,
    time TEXT NOT NULL);
CREATE TABLE marks (
    student TEXT NOT NULL, lesson TEXT NOT NULL, question TEXT NOT NULL, points REAL NOT NULL, comment TEXT NOT NULL,
    time TEXT NOT NULL);
CREATE TABLE runs (submissions TEXT NOT NULL, time TEXT NOT NULL);
PRAGMA application_id = {APPLICATION};
"""
VERSION_2 = """
CREATE TABLE IF NOT EXISTS comments (
    lesson TEXT NOT NULL, exercise TEXT NOT NULL, kind TEXT NOT NULL, text TEXT NOT NULL, time TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS requests (
    student TEXT NOT NULL, lesson TEXT NOT NULL, exercise TEXT NOT NULL, text TEXT NOT NULL, answer TEXT NOT NULL,
    time TEXT NOT NULL);
ALTER TABLE overrides ADD COLUMN decided_on TEXT NOT NULL DEFAULT '';
ALTER TABLE overrides ADD COLUMN earned REAL NOT NULL DEFAULT 0;
ALTER TABLE marks ADD COLUMN decided_on TEXT NOT NULL DEFAULT '';
ALTER TABLE comments ADD COLUMN decided_on TEXT NOT NULL DEFAULT '';
ALTER TABLE requests ADD COLUMN decided_on TEXT NOT NULL DEFAULT '';
PRAGMA user_version = 2;
"""
# The students are in the journal, and not in a file beside it, so that one transaction changes who a person is and
# whose the results are, and two graders that run at once agree on it.
VERSION_3 = """
CREATE TABLE IF NOT EXISTS students (
    student TEXT PRIMARY KEY, name TEXT NOT NULL, email TEXT NOT NULL, login TEXT NOT NULL, section TEXT NOT NULL,
    listed INTEGER NOT NULL);
CREATE TABLE IF NOT EXISTS aliases (alias TEXT PRIMARY KEY, student TEXT NOT NULL, lesson TEXT NOT NULL);
PRAGMA user_version = 3;
"""
VERSION_4 = """
CREATE TABLE IF NOT EXISTS commands (
    number INTEGER PRIMARY KEY AUTOINCREMENT, words TEXT NOT NULL, given_by TEXT NOT NULL,
    time TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS replaced (command INTEGER NOT NULL, name TEXT NOT NULL, row INTEGER NOT NULL, old TEXT);
ALTER TABLE overrides ADD COLUMN given_by TEXT NOT NULL DEFAULT '';
ALTER TABLE overrides ADD COLUMN is_withdrawn INTEGER NOT NULL DEFAULT 0;
ALTER TABLE marks ADD COLUMN given_by TEXT NOT NULL DEFAULT '';
ALTER TABLE marks ADD COLUMN is_withdrawn INTEGER NOT NULL DEFAULT 0;
ALTER TABLE marks ADD COLUMN is_second INTEGER NOT NULL DEFAULT 0;
ALTER TABLE comments ADD COLUMN given_by TEXT NOT NULL DEFAULT '';
ALTER TABLE requests ADD COLUMN given_by TEXT NOT NULL DEFAULT '';
PRAGMA user_version = 4;
"""
OF_STUDENTS = ("results", "history", "overrides", "marks", "requests", "aliases", "students")  # tables
