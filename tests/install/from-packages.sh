#!/usr/bin/env bash
# Installs the Debian packages of a folder on this machine and uses them as a newcomer would: the programs, a consumer by
# find_package, one by pkg-config, examples in Python, two ranks of MPI. For a bare machine: tests/install/from-packages.sh FOLDER
set -euo pipefail
packages=$(readlink -f "$1")
cd "$(dirname "$(readlink -f "$0")")/consumer"
examples=$(readlink -f ../../../examples)
export DEBIAN_FRONTEND=noninteractive
# installed PATTERN...: lists those of these packages that are installed; false if none is. dpkg-query fails for unknown ones.
installed() { { dpkg-query -W -f '${db:Status-Status} ${Package}\n' "$@" 2>/dev/null || true; } | grep '^installed'; }
apt-get update -qq
apt-get install -y -qq --no-install-recommends "$packages"/libtandem0_*.deb "$packages"/libtandem-dev_*.deb >/dev/null
if installed 'libfcl0*' 'libccd2*' 'liboctomap1*'; then
  echo "libtandem-dev brings libraries that distances do not need" >&2
  exit 1
fi
apt-get install -y -qq --no-install-recommends g++ cmake make pkgconf "$packages"/tandem-tools_*.deb >/dev/null
work=$(mktemp -d)
cmake -S . -B "$work" >/dev/null
cmake --build "$work"
"$work"/consumer
"$work"/by_shared_library
"$work"/distance
# shellcheck disable=SC2046 # several flags
g++ main.cpp -o "$work"/by_pkg_config $(pkg-config --cflags --libs tandem)
"$work"/by_pkg_config
tandem run cubes-on-plane --steps 5
for x in 0 0.5; do # two tetrahedra that intersect
  printf 'v %s 0 0\nv 1 1 0\nv 1 0 1\nv 1.5 0 0\nf 1 3 2\nf 1 4 3\nf 1 2 4\nf 2 3 4\n' "$x" >"$work/part-$x.obj"
done
tandem clash "$work"/part-0.obj "$work"/part-0.5.obj --report "$work"/clashes.html | tee "$work"/clashes.txt
grep -q '^1 of 1 pairs' "$work"/clashes.txt
tandem-bench --version
apt-get install -y -qq --no-install-recommends "$packages"/python3-tandem_*.deb >/dev/null
for example in first_distance falling_pile planner; do
  (cd "$work" && python3 "$examples/python/$example.py")
done
if installed 'libopenmpi*' 'libtrilinos*'; then
  echo "the packages for one machine bring MPI" >&2
  exit 1
fi
apt-get install -y -qq --no-install-recommends "$packages"/tandem-mpi_*.deb "$packages"/libtandem-mpi-dev_*.deb >/dev/null
cmake -S . -B "$work" >/dev/null
cmake --build "$work" --target ranks
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
mpirun --oversubscribe -n 2 "$work"/ranks
mpirun --oversubscribe -n 2 tandem-mpi run cubes-on-plane --steps 5
apt-get install -y -qq --no-install-recommends libfcl-dev binutils >/dev/null
cmake -S . -B "$work" >/dev/null
cmake --build "$work"
"$work"/from_fcl
../../../docs/table-links "$work"
rm -r "$work"
echo "packages: all works"
