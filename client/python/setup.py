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

    def get_outputs(self, include_bytecode=True):
        made = [str(Path(self.build_lib) / "isostrata" / "v1" / name) for name in ("isostrata_pb2.py", "isostrata_pb2.pyi")]
        return super().get_outputs(include_bytecode) + made


setup(cmdclass={"build_py": BuildWithMessages})
