"""The rest is in pyproject.toml; here only what it cannot say: the messages are made by protoc (protobuf-compiler)."""

import subprocess
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

PROTOCOL = Path(__file__).resolve().parent.parent.parent / "protocol"


class BuildWithMessages(build_py):
    def run(self):
        super().run()
        self.mkpath(str(Path(self.build_lib) / "isostrata" / "v1"))
        proto = PROTOCOL / "isostrata" / "v1" / "isostrata.proto"
        subprocess.run(
            ["protoc", f"--python_out={self.build_lib}", f"--pyi_out={self.build_lib}", f"-I{PROTOCOL}", str(proto)], check=True
        )

    def find_all_modules(self):
        return [module for module in super().find_all_modules() if module[0] != "isostrata.v1"]


setup(cmdclass={"build_py": BuildWithMessages})
