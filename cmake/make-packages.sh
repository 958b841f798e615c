#!/usr/bin/env bash
# Builds Debian packages of this checkout in build/packages, for the Debian that this runs on, and lets lintian judge them:
# cmake/make-packages.sh [--no-install]. TANDEM_CMAKE_OPTIONS: more options for CMake.
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/.."
cmake/install-packages.sh "$@" dpkg-dev file lintian pybind11-dev python3-dev python3-numpy \
  libopenmpi-dev libtrilinos-zoltan-dev
# shellcheck disable=SC2086 # several options
cmake --preset packages ${TANDEM_CMAKE_OPTIONS-} >/dev/null
cmake --build --preset packages
rm -f build/packages/*.deb
(cd build/packages && cpack)
lintian --allow-root --fail-on error build/packages/*.deb
ls -l build/packages/*.deb
