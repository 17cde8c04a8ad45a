#!/bin/sh
# Makes the Debian packages of a build and looks into them; unpacked side by side, they run.
#   contents.sh CPACK BUILD SOURCE WORK ABI VERSION
# A build for this processor is refused first, and then packed all the same, for this test alone.
set -eu
cpack=$1 build=$2 source=$3 work=$4 abi=$5 version=$6
rm -rf "$work" && mkdir -p "$work"
cd "$work"

fail() {
  echo "$*" >&2
  exit 1
}
has() {  # PACKAGE PATTERN...: files that it must have, and only it
  package=$1 && shift
  for pattern; do
    owners=$(grep -lE "$pattern" ./*.list | tr '\n' ' ')
    [ "$owners" = "./$package.list " ] || fail "$pattern is in \"$owners\", not in $package alone"
  done
}
depends() {  # PACKAGE NAME...
  package=$1 && shift
  found=$(dpkg-deb -f packages/"${package}"_*.deb Depends)
  for name; do
    echo ", $found," | grep -qE ", $name( \([^)]*\))?," || fail "$package does not depend on $name: $found"
  done
}

if grep -q 'PALPATE_NATIVE:BOOL=ON' "$build/CMakeCache.txt"; then
  if (cd "$build" && "$cpack" -B "$work/refused") >refused.log 2>&1; then
    fail "a build for this processor was packed"
  fi
  grep -q tools/packages refused.log || fail "$(cat refused.log)"
fi
(cd "$build" && "$cpack" -B "$work/packages" -D CPACK_PALPATE_NATIVE=OFF) >cpack.log 2>&1 || fail "$(cat cpack.log)"
for deb in packages/*.deb; do
  name=$(dpkg-deb -f "$deb" Package)
  dpkg-deb -c "$deb" | awk '$1 !~ /^d/ {print $6}' >"$name.list"
  dpkg-deb -x "$deb" unpacked
  [ "$(dpkg-deb -f "$deb" Version)" = "$version" ] || fail "$deb: $(dpkg-deb -f "$deb" Version)"
  grep -q "doc/$name/copyright$" "$name.list" || fail "$name says nothing of its licence"
done
doubled=$(cat ./*.list | sort | uniq -d)
[ -z "$doubled" ] || fail "in two packages: $doubled"

has palpate /usr/bin/mtled$
has palpate-data /usr/share/palpate/assets/scenes/liver.toml$ /usr/share/palpate/assets/organs/liver.obj$
has libpalpate "/libpalpate\.so\.$version$" "/libpalpate\.so\.$abi "'?'
has libpalpate-dev /include/palpate.h$ /include/palpate_device.h$ /pkgconfig/palpate.pc$ \
  /cmake/Palpate/PalpateConfig.cmake$ /libpalpate.so$
has python3-palpate /usr/lib/python3/dist-packages/palpate/__init__.py$
depends palpate libc6 palpate-data
depends libpalpate libc6 palpate-data
depends libpalpate-dev libpalpate
depends python3-palpate python3-numpy libpalpate
if dpkg-deb -f packages/libpalpate_*.deb Depends | grep -E 'glfw|epoxy|libgl|libegl'; then
  fail "libpalpate needs a window"
fi
if [ -e libpalpate-image.list ]; then
  has palpate /usr/bin/palpate$
  has palpate-data /usr/share/palpate/shaders/frame.glsl$
  has libpalpate-image "/libpalpate_image\.so\.$version$"
  depends libpalpate-image libpalpate libepoxy0
  unpacked/usr/bin/palpate --version | grep -q "^palpate $version," || fail "palpate --version"
fi

if [ -e palpate-igtl.list ]; then
  has palpate-igtl /usr/bin/palpate-igtl$
  depends palpate-igtl libpalpate libopenigtlink1.11
fi

# Unpacked, without what -dev brings and far from the source tree.
find unpacked -name 'libpalpate*.so' -delete
unset PALPATE_LIBRARY PALPATE_DATA_DIR
export PYTHONDONTWRITEBYTECODE=1
scenes='import palpate, os; print(palpate.find_library()); palpate.Model("layer_sphere"); print(palpate.version())'
(cd / && PYTHONPATH="$work/unpacked/usr/lib/python3/dist-packages" /usr/bin/python3 -c "$scenes") >python.log
grep -q "^$work/unpacked/usr/lib.*/libpalpate.so.$abi$" python.log || fail "$(cat python.log)"
grep -qx "$version" python.log || fail "$(cat python.log)"

# A wheel, made without a network, finds the library where the system's loader does.
cp -r "$source/tools/python" wheel
if /usr/bin/python3 -c 'import pip, setuptools, wheel, venv, ensurepip' 2>missing.log; then
  /usr/bin/python3 -m pip -q wheel --no-deps --no-build-isolation --no-index -w wheels ./wheel >wheel.log 2>&1 ||
    fail "$(cat wheel.log)"
  /usr/bin/python3 -m venv --system-site-packages there
  there/bin/python -m pip -q install --no-deps --no-index wheels/palpate-"$version"-*.whl >>wheel.log 2>&1 ||
    fail "$(cat wheel.log)"
  if (cd / && "$work/there/bin/python" -c "$scenes") >wheel.log 2>&1; then
    grep -q '^libpalpate.so' wheel.log || fail "another library was found: $(cat wheel.log)"  # one is installed here
  else
    grep -q "install or build Palpate" wheel.log || fail "$(cat wheel.log)"
  fi
  libraries=$(dirname "$(find "$work/unpacked" -name "libpalpate.so.$abi")")
  (cd / && LD_LIBRARY_PATH=$libraries "$work/there/bin/python" -c "$scenes") >wheel.log 2>&1 || fail "$(cat wheel.log)"
  grep -qx "libpalpate.so.$abi" wheel.log && grep -qx "$version" wheel.log || fail "$(cat wheel.log)"
else
  echo "no wheel was tried: $(tail -n 1 missing.log) (python3-pip, python3-venv, python3-wheel)"
fi
echo "all held"
