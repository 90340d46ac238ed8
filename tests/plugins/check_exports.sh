#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# Fails where a plugin exports anything but its stamp and its entry function.
# Usage: check_exports.sh NM LIBRARY
symbols=$("$1" -D --defined-only "$2" | sed 's/^[^ ]* [^ ]* //; s/@.*//' | sort | tr '\n' ' ')
[ "$symbols" = "graft_plugin_register graft_plugin_stamp " ] && exit 0
echo "$2 exports: $symbols" >&2
exit 1
