#!/bin/sh
# Installs a release of the course for all users of this machine, or replaces it by a newer one.
# sh install.sh nao-course-0.1.0.zip [/opt/nao-course]
set -eu
release=$1
folder=${2:-/opt/nao-course}
here=$(cd "$(dirname "$0")" && pwd)
umask 022  # students read all of it, and only root writes
mkdir -p "$folder"
test -x "$folder/.venv/bin/python" || "${PYTHON:-python3}" -m venv "$folder/.venv"
if [ "$(id -u)" -eq 0 ] && ! setpriv --reuid=65534 --regid=65534 --clear-groups "$folder/.venv/bin/python" -c ''; then
    rm -rf "$folder/.venv"
    echo "Students could not run this Python, which is root's own. Name one of the system: PYTHON=/usr/bin/python3 sh install.sh ..." >&2
    exit 1
fi
"$folder/.venv/bin/python" -m pip install --quiet --require-hashes -r "$here/requirements.lock"
# The zip holds the library and the students' notebooks: nothing of the instructor's side can get here.
rm -rf "$folder/new"
"$folder/.venv/bin/python" -m zipfile -e "$release" "$folder/new"
"$folder/.venv/bin/python" -m pip install --quiet --no-deps --no-build-isolation --force-reinstall "$folder/new/nao-course"
rm -rf "$folder/release"
mv "$folder/new/nao-course/release" "$folder/release"
rm -rf "$folder/new"
# Compiled once, by root: students cannot write the compiled files, and each start would compile again.
"$folder/.venv/bin/python" -m compileall -q "$folder/.venv/lib" || true
echo "$folder: $("$folder/.venv/bin/python" -m pip list 2>/dev/null | grep '^nao-course ')"
