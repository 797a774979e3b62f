#!/bin/sh
# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
# A compiler that compiles a file of one name once: compile_once.sh FOLDER COMPILER WORDS...
# For copies of one tree that are built one after the other; FOLDER keeps what was compiled.
set -eu
kept=$1
shift
source=
object=
before=
for word in "$@"; do
    case $word in *.cpp) source=$word ;; esac
    if [ "$before" = -o ]; then object=$word; fi
    before=$word
done
case $object in *.o) ;; *) exec "$@" ;; esac
copy=$kept/$(basename "$source").o
if [ ! -f "$copy" ]; then
    "$@"
    cp "$object" "$copy.$$"
    mv "$copy.$$" "$copy"
else
    mkdir -p "$(dirname "$object")"
    cp "$copy" "$object"
fi
