"""The examples of client/python/README.md run as they stand there."""
import contextlib
import io
import os
import re
import shutil
import unittest

import server


def blocks_of(page):
    return re.findall(r"^```python\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)


class Readme(unittest.TestCase):
    def test_examples(self):
        page = (server.SOURCE / "client/python/README.md").read_text()
        blocks = blocks_of(page)
        self.assertGreaterEqual(len(blocks), 4)
        with server.Folder() as folder, server.Server(folder / "a.db") as running:
            for file in server.EXAMPLE.glob("B-*.csv"):
                shutil.copy(file, folder)
            shutil.copy(server.EXAMPLE / "machine.json", folder)
            shutil.copy(server.EXAMPLE / "fig-4.30-original.nc", folder / "part.nc")
            shutil.copy(server.EXAMPLE / "fig-5.13-touch-log.txt", folder / "probe.log")
            shutil.copy(server.EXAMPLE / "fig-5.13.template", folder / "probe.template")
            (folder / "broken.csv").write_text((server.EXAMPLE / "B-short-run1.csv").read_text().replace("-493.2167", "-493,2167"))
            self.assertIn('connect("127.0.0.1:7410")', blocks[0])
            blocks[0] = blocks[0].replace('"127.0.0.1:7410"', repr(running.address))
            printed = io.StringIO()
            names = {}
            was = os.getcwd()
            os.chdir(folder)
            try:
                with contextlib.redirect_stdout(printed):
                    for block in blocks:
                        exec(compile(block, "client/python/README.md", "exec"), names)  # a failure shows the line of the block
            finally:
                os.chdir(was)
                if "client" in names:
                    names["client"].close()
            text = printed.getvalue()
            self.assertRegex(text, r"EZ0T 3\d{3}\.\d+ \+- \d")
            self.assertRegex(text, r"10 blocks; 3\d{3}\.\d+ -> 0\.\d+ um")
            self.assertIn("ball-B0 21 readings from lines 4 to 24", text)
            self.assertIn("known_share", text)
            self.assertIn("CALIBRATION_NOT_FOUND", text)
            self.assertIn("broken.csv: line 12", text)
            self.assertGreater(len((folder / "corrected.nc").read_bytes().splitlines()), 10)

    def test_options_table_is_complete(self):
        import dataclasses

        import axiscal
        page = (server.SOURCE / "client/python/README.md").read_text()
        for field in dataclasses.fields(axiscal.Options):
            self.assertIn(f"`{field.name}`", page)
            self.assertIn("AXISCAL_" + field.name.upper(), page)


if __name__ == "__main__":
    unittest.main()
