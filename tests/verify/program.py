# SPDX-License-Identifier: BSD-3-Clause
"""What the tests of this folder share: the programs, the data, temporary folders.
Set by ctest: GRAFT_BINARY_DIR (build folder), GRAFT_DATA_DEFAULT."""
import os
import shutil
import subprocess
import tempfile
import unittest

BUILD = os.environ.get("GRAFT_BINARY_DIR", "build")
PROGRAM = os.path.join(BUILD, "bin", "graft-lfd")
DATA = os.environ.get("GRAFT_DATA") or os.environ.get("GRAFT_DATA_DEFAULT", "../shared/data")


def run(*arguments):
    """Runs graft-lfd with the reachability maps of all tests of this build."""
    environment = dict(os.environ, GRAFT_CACHE_DIR=os.path.abspath(
        os.path.join(BUILD, "tests", "cache")))
    return subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, check=False,
                          env=environment)


class FolderTest(unittest.TestCase):
    """A class with a temporary folder for all its cases."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="graft-verify-")
        cls.addClassCleanup(shutil.rmtree, cls.folder)

    @classmethod
    def path(cls, *names):
        return os.path.join(cls.folder, *names)

    def must_run(self, *arguments):
        result = run(*arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result

    def data(self, name):
        """Path of a file of the evaluation data; skips the case without it."""
        path = os.path.join(DATA, name)
        if not os.path.exists(path):
            self.skipTest(f"needs {path} (set GRAFT_DATA to the folder of the evaluation data)")
        return path
