"""Builds the package with messages and stubs that protoc makes of proto/axiscal/v1: nothing generated is kept in the checkout.

AXISCAL_SOURCE: root of the checkout, where this folder was copied elsewhere (by CMake, which keeps the checkout clean).
"""
import os
import pathlib
import re
import shutil
import subprocess

from setuptools import setup
from setuptools.command.build_py import build_py

ROOT = pathlib.Path(os.environ.get("AXISCAL_SOURCE") or pathlib.Path(__file__).resolve().parent.parent.parent)
VERSION = re.search(r"project\(axiscal VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text())[1]


class BuildWithProtos(build_py):
    def run(self):
        super().run()
        out = pathlib.Path(self.build_lib)
        plugin = shutil.which("grpc_python_plugin")
        if plugin is None or shutil.which("protoc") is None:
            raise SystemExit("protoc and grpc_python_plugin are needed (Debian: protobuf-compiler, protobuf-compiler-grpc)")
        protos = sorted((ROOT / "proto/axiscal/v1").glob("*.proto"))
        subprocess.run(["protoc", "-I", ROOT / "proto", f"--python_out={out}", f"--pyi_out={out}", f"--grpc_python_out={out}",
                        f"--plugin=protoc-gen-grpc_python={plugin}", *protos], check=True)
        third_party = ROOT / "proto/third_party"
        subprocess.run(["protoc", "-I", third_party, "--include_imports", f"--descriptor_set_out={out}/axiscal/v1/google_rpc.desc",
                        third_party / "google/rpc/status.proto", third_party / "google/rpc/error_details.proto"], check=True)
        (out / "axiscal/_version.py").write_text(f'VERSION = "{VERSION}"\n')

    def get_outputs(self, include_bytecode=True):
        generated = [str(path) for path in pathlib.Path(self.build_lib).glob("axiscal/v1/*")]
        return super().get_outputs(include_bytecode) + generated


setup(version=VERSION, cmdclass={"build_py": BuildWithProtos})
