#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Installs the Debian packages that graft builds and tests with, if any is
# missing. Usage: bash .ci/packages.sh [extra packages ...]
set -euo pipefail

packages=(
  g++ cmake ninja-build ccache binutils                  # build
  libeigen3-dev libsuitesparse-dev libmetis-dev          # core
  libtinyxml2-dev libcli11-dev nlohmann-json3-dev libpng-dev
  libgtest-dev python3                                   # tests
  "$@"
)

missing=()
for package in "${packages[@]}"; do
  if ! dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'install ok installed'; then
    missing+=("$package")
  fi
done
[ "${#missing[@]}" -eq 0 ] && exit 0

echo "Installing: ${missing[*]}"
as_root=()
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo >/dev/null; then
    echo "error: needs root (or sudo) to install: ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo)
fi
export DEBIAN_FRONTEND=noninteractive
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
