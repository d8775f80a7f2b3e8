#!/bin/sh
# Compile the library in the order of _CoqProject, into the folder given (default: here). Needs coq, libcoq-coquelicot, libcoq-flocq.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
out=${1:-$here}
mkdir -p "$out"
cd "$out"
for file in $(sed -n 's/\.v$//p' "$here/_CoqProject"); do
    [ "$out" = "$here" ] || cp "$here/$file.v" .
    coqc -q -w -ambiguous-paths,-abstract-large-number -Q . Stt "$file.v"
done
