# CMake compiles the module; setuptools packs it. HDMBENCH_BUILD_FOLDER names a build folder with HDMBENCH_PYTHON=ON to
# take; without it build/python is made.
import os
import pathlib
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

project = pathlib.Path(__file__).resolve().parents[2]


class BuildByCMake(build_ext):
    def build_extension(self, extension):
        folder = pathlib.Path(os.environ.get("HDMBENCH_BUILD_FOLDER", project / "build" / "python"))
        if not (folder / "CMakeCache.txt").exists():
            options = ["-DCMAKE_BUILD_TYPE=Release", "-DHDMBENCH_PYTHON=ON", "-DHDMBENCH_TESTS=OFF",
                       f"-DPython_EXECUTABLE={sys.executable}"]
            subprocess.run(["cmake", "-G", "Ninja", "-S", project, "-B", folder, *options], check=True)
        subprocess.run(["cmake", "--build", folder, "--target", "hdmbench_python"], check=True)
        target = pathlib.Path(self.get_ext_fullpath(extension.name))
        target.parent.mkdir(parents=True, exist_ok=True)
        (built,) = (folder / "python" / "hdmbench").glob("_hdmbench.*.so")
        shutil.copy(built, target)


# Nothing is left among the sources.
made = project / "build" / "pip"
made.mkdir(parents=True, exist_ok=True)
setup(
    ext_modules=[Extension("hdmbench._hdmbench", sources=[])],
    cmdclass={"build_ext": BuildByCMake},
    options={"build": {"build_base": str(made)}, "egg_info": {"egg_base": str(made)}},
)
