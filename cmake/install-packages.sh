#!/usr/bin/env bash
# Installs the packages that the build and most tests need, and those named as arguments, by the system's package manager.
# Does nothing, quickly, if all are installed. With --no-install first it lists the missing ones and continues.
set -euo pipefail

install=yes
if [ "${1-}" = --no-install ]; then install=no && shift; fi

packages=(
  g++ cmake ninja-build ca-certificates
  libtbb-dev libeigen3-dev libfcl-dev libccd-dev libhwy-dev libqhull-dev
  nlohmann-json3-dev libcli11-dev libfmt-dev
  catch2 libboost-dev
  zlib1g-dev libjs-three node-d3
  "$@"
)

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
  echo "tandem: this system has no apt; please install the equivalents of: ${packages[*]}" >&2
  [ $install = no ] # with --no-install, go on with what is there
  exit
fi
missing=()
for package in "${packages[@]}"; do
  dpkg-query -W -f '${db:Status-Status}\n' "$package" 2>/dev/null | grep -qx installed || missing+=("$package")
done
[ ${#missing[@]} -gt 0 ] || exit 0
if [ $install = no ]; then
  echo "tandem: not installed, as asked: ${missing[*]}" >&2
  exit 0
fi

sudo=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || { echo "tandem: run as root, or install: ${missing[*]}" >&2; exit 1; }
  sudo=(sudo)
fi
echo "tandem: installing ${missing[*]}" >&2
export DEBIAN_FRONTEND=noninteractive
"${sudo[@]}" apt-get update -qq >&2
"${sudo[@]}" apt-get install -y -qq --no-install-recommends "${missing[@]}" >&2
