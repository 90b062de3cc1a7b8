#!/bin/sh
# The steps of the image, also where there is no container engine: sh deploy/install.sh [PYTHON], from the clone's root.
# Every file that is installed is one of deploy/requirements.lock, by its SHA-256; the project itself is built from here.
set -eu
python="${1:-python}"
export PIP_NO_CACHE_DIR=1 PIP_DISABLE_PIP_VERSION_CHECK=1
"$python" -m pip install --require-hashes --only-binary=:all: -r deploy/requirements.lock
"$python" -m pip install --no-deps --no-build-isolation .
"$python" -I -m viewimit.commands.cli --version
