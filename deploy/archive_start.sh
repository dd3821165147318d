#!/bin/sh
# Starts the program of its name from the folder in which it lies, with the C library and the libraries beside it: of this machine it takes
# the kernel, and where a GPU has a driver of its own (NVIDIA) that driver. deploy/archive puts it into the download, once a program.
program=isostrata

self=$0
case $self in
  */*) ;;
  *) if [ -f "$self" ]; then self=./$self; else self=$(command -v "$self"); fi ;;
esac
while [ -h "$self" ]; do # a link to it, say in ~/bin
  to=$(readlink "$self")
  case $to in
    /*) self=$to ;;
    *) self=${self%/*}/$to ;;
  esac
done
# shellcheck disable=SC1007  # an empty CDPATH for this one command
home=$(CDPATH= cd -- "${self%/*}" && pwd -P) || exit 1
case $home in
  *[:\;]*)
    echo "$program: it lies in '$home', and the loader of programs takes no folder with ':' or ';' in its name: move it" >&2
    exit 1
    ;;
esac

# EGL asks the machine's own drivers first, but for its Mesa: the Mesa beside this script fits the libraries beside it, and knows GPUs too.
if [ -z "${__EGL_VENDOR_LIBRARY_FILENAMES+set}" ]; then
  __EGL_VENDOR_LIBRARY_FILENAMES=
  for file in /etc/glvnd/egl_vendor.d/*.json /usr/share/glvnd/egl_vendor.d/*.json; do
    case $file in
      *\** | *mesa*) ;;
      *) __EGL_VENDOR_LIBRARY_FILENAMES=$__EGL_VENDOR_LIBRARY_FILENAMES$file: ;;
    esac
  done
  export __EGL_VENDOR_LIBRARY_FILENAMES="$__EGL_VENDOR_LIBRARY_FILENAMES$home/share/isostrata/egl/50_mesa.json"
fi
export ISOSTRATA_PROGRAM="$home/isostrata" # what isostrata view starts
export LIBGL_DRIVERS_PATH="$home/lib/dri"
export LIBHEIF_PLUGIN_PATH="$home/lib/heif" # where there are none: OpenImageIO's library for HEIF would load the machine's own

exec "$home/lib/ld-linux-x86-64.so.2" --library-path "$home/lib" --argv0 "$0" "$home/programs/$program" "$@"
