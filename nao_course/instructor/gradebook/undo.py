"""Undo: what a command replaces in the journal is kept row by row, and put back in the opposite order.

Temporary triggers of the connection keep it, so that no statement that changes the journal can be forgotten, and
another grader's changes at the same time are not taken for the command's.
"""

import json
from collections.abc import Sequence
from sqlite3 import Connection

_TABLES = ("results", "history", "overrides", "marks", "comments", "requests", "students", "aliases")


def begin(database: Connection, words: str, given_by: str, time: str) -> int:
    """Keep from now on what the connection replaces, and return the command's number."""
    database.execute("PRAGMA recursive_triggers = ON")  # so that INSERT OR REPLACE is seen to delete
    values = (words, given_by, time)
    number = database.execute(
        "INSERT INTO commands (words, given_by, time) VALUES (?, ?, ?)", values
    ).lastrowid
    for table in _TABLES:
        old = f"json_array({', '.join(f'OLD.{column}' for column in _columns(database, table))})"
        for change, row, kept in (("INSERT", "NEW", "NULL"), ("UPDATE", "OLD", old), ("DELETE", "OLD", old)):
            database.execute(
                f"CREATE TEMP TRIGGER undo_{table}_{change} AFTER {change} ON main.{table} BEGIN "
                f"INSERT INTO replaced VALUES ({number}, '{table}', {row}.rowid, {kept}); END"
            )
    return number or 0


def end(database: Connection, number: int) -> None:
    """Stop to keep what is replaced.

    A command that changed nothing is forgotten, and so is a command during which another run of the grader began.
    """
    for table in _TABLES:
        for change in ("INSERT", "UPDATE", "DELETE"):
            database.execute(f"DROP TRIGGER temp.undo_{table}_{change}")
    database.execute(
        "DELETE FROM commands WHERE number = ? AND NOT EXISTS (SELECT * FROM replaced WHERE command = ?)",
        (number, number),
    )
    database.execute("DELETE FROM replaced WHERE command NOT IN (SELECT number FROM commands)")


def take_back(database: Connection, number: int) -> None:
    """Put back the rows that a command replaced, and forget the command."""
    kept = database.execute(
        "SELECT name, row, old FROM replaced WHERE command = ? ORDER BY rowid DESC", (number,)
    ).fetchall()
    for table, row, old in kept:
        if old is None:
            database.execute(f"DELETE FROM {table} WHERE rowid = ?", (row,))
        else:
            names = ("rowid", *_columns(database, table))
            database.execute(
                f"INSERT OR REPLACE INTO {table} ({', '.join(names)}) VALUES ({', '.join('?' * len(names))})",
                (row, *json.loads(old)),
            )
    database.execute("DELETE FROM replaced WHERE command = ?", (number,))
    database.execute("DELETE FROM commands WHERE number = ?", (number,))


def forget_commands(database: Connection) -> None:
    """Forget all commands: after a run of the grader, or when a student's data is deleted, none can be undone."""
    database.execute("DELETE FROM replaced")
    database.execute("DELETE FROM commands")


def _columns(database: Connection, table: str) -> Sequence[str]:
    return [row[1] for row in database.execute(f"PRAGMA main.table_info({table})")]
