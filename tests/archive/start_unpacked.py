"""The download starts in an empty root, or where this is not root's in a folder that has moved, and takes nothing of the machine.

    start_unpacked.py BUILD     what deploy/prove-archive proves of `empty` or `here`, with what is built, not packed
"""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

DEPLOY = pathlib.Path(__file__).resolve().parents[2] / "deploy"
PAGE = DEPLOY.parent / "web/dist/index.html"


def can_make_roots():
    """Root of a container often may not mount."""
    apart = ["unshare", "--mount", "--pid", "--fork", "--mount-proc", "mount", "-t", "tmpfs", "tmpfs", "/mnt"]
    return os.geteuid() == 0 and bool(shutil.which("busybox")) and subprocess.run(apart, capture_output=True).returncode == 0


def main():
    with tempfile.TemporaryDirectory(prefix="isostrata archive ") as folder:
        made, moved = pathlib.Path(folder, "made"), pathlib.Path(folder, "moved elsewhere")
        page = [] if PAGE.exists() else ["--without-page"]
        if subprocess.run([DEPLOY / "archive", "--build", sys.argv[1], "--unpacked", made, *page]).returncode:
            return 1
        made.rename(moved)
        os.environ.pop("LD_LIBRARY_PATH", None)
        root = "empty" if can_make_roots() else "here"
        return subprocess.run([DEPLOY / "prove-archive", moved / "isostrata", root]).returncode


sys.exit(main())
