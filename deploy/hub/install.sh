#!/bin/sh
# Installs a release of the course for all users of this machine, beside the releases that are there, and makes it the
# current one; with --back, the release before it is the current one again.
# sh install.sh nao-course-0.1.0.zip [/opt/nao-course]
# sh install.sh --back [/opt/nao-course]
set -eu
release=$1
folder=${2:-/opt/nao-course}
here=$(cd "$(dirname "$0")" && pwd)
umask 022  # students read all of it, and only root writes

# A link is replaced in one step, so a server that starts at this moment gets one of the two releases.
point() {
    ln -sfn "$2" "$folder/$1.new"
    mv -T "$folder/$1.new" "$folder/$1"
}

if [ "$release" = --back ]; then
    test -L "$folder/previous" || { echo "$folder has no release before the current one." >&2; exit 1; }
    before=$(readlink "$folder/previous")
    point previous "$(readlink "$folder/current")"
    point current "$before"
    echo "$folder: ${before#versions/} is current again"
    exit
fi

version=$(basename "$release" .zip)
version=${version#nao-course-}
place=$folder/versions/$version
if [ -e "$place" ]; then
    echo "$place exists. A new release has a new version in course.toml. To install this one again, remove the folder." >&2
    exit 1
fi
mkdir -p "$folder/versions"
trap 'rm -rf "$place"' EXIT  # no half of an installation stays
"${PYTHON:-python3}" -m venv "$place/.venv"
if [ "$(id -u)" -eq 0 ] && ! setpriv --reuid=65534 --regid=65534 --clear-groups "$place/.venv/bin/python" -c ''; then
    echo "Students could not run this Python, which is root's own. Name one of the system: PYTHON=/usr/bin/python3 sh install.sh ..." >&2
    exit 1
fi
"$place/.venv/bin/python" -m pip install --quiet --require-hashes -r "$here/requirements.lock"
# The zip holds the library and the students' notebooks: nothing of the instructor's side can get here.
"$place/.venv/bin/python" -m zipfile -e "$release" "$place/new"
"$place/.venv/bin/python" -m pip install --quiet --no-deps --no-build-isolation "$place/new/nao-course"
mv "$place/new/nao-course/release" "$place/release"
rm -rf "$place/new"
# Compiled once, by root: students cannot write the compiled files, and each start would compile again.
"$place/.venv/bin/python" -m compileall -q "$place/.venv/lib" || true
trap - EXIT
if [ -L "$folder/current" ]; then
    point previous "$(readlink "$folder/current")"
fi
point current "versions/$version"
echo "$folder: $("$place/.venv/bin/python" -m pip list 2>/dev/null | grep '^nao-course ')"
