# A recipe for Spack, from a clone: docs/installing.md. It was written from deploy/packages.txt and has not been tried.
from spack.package import *


class Isostrata(CMakePackage):
    """Interval volumes of scalar fields, extracted exactly and streamed to a browser."""

    license("Apache-2.0")
    version("develop")  # only from a clone: spack dev-build isostrata@develop

    variant("import", default=True, description="Read foreign files, by VTK's readers")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("cmake@3.25:", type="build")
    depends_on("ninja", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("node-js@18:", type="build")  # the page; npm fetches what web/package-lock.json pins
    depends_on("npm", type="build")

    depends_on("boost@1.81:")
    depends_on("bzip2")
    depends_on("c-blosc", when="+import")
    depends_on("cli11")
    depends_on("egl")
    depends_on("freetype")
    depends_on("highway")
    depends_on("libdeflate")
    depends_on("libjpeg-turbo")
    depends_on("libseccomp")
    depends_on("libvpx")
    depends_on("libwebp")
    depends_on("lz4", when="+import")
    depends_on("openimageio")
    depends_on("openssl@3:")
    depends_on("prometheus-cpp")
    depends_on("protobuf@3.21:")
    depends_on("spdlog")
    depends_on("vtk@9.1:", when="+import")
    depends_on("zlib-api")
    depends_on("zstd", when="+import")

    def cmake_args(self):
        return [self.define_from_variant("ISOSTRATA_IMPORT", "import"), self.define("ISOSTRATA_TESTS", False)]

    @run_before("cmake")
    def build_page(self):
        with working_dir("web"):
            npm = which("npm")
            npm("ci", "--no-audit", "--no-fund")
            npm("run", "build")
