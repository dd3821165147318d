"""Runs the tests of one file against the package in build/PRESET/python: run.py PACKAGE_FOLDER FILE. Status 77: something that they
need is not installed."""

import faulthandler
import sys
import unittest
from pathlib import Path

package, file = sys.argv[1:3]
try:
    import google.protobuf  # noqa: F401
    import numpy  # noqa: F401
    import PIL  # noqa: F401
    import websockets  # noqa: F401
except ImportError as missing:
    print(f"{missing}; deploy/setup test installs it")
    sys.exit(77)
sys.path[:0] = [package, str(Path(__file__).resolve().parent)]
sys.dont_write_bytecode = True
faulthandler.dump_traceback_later(240, exit=True)  # before ctest's limit, which would not say where it hangs
tests = unittest.defaultTestLoader.loadTestsFromName(Path(file).stem)
sys.exit(not unittest.TextTestRunner(verbosity=2).run(tests).wasSuccessful())
