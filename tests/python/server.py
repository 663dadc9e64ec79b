"""axiscald as a process of its own, for the tests of the Python client.

AXISCALD, AXISCAL: the programs. AXISCAL_SOURCE: root of the checkout. CMake sets them.
"""
import json
import os
import pathlib
import shutil
import socket
import subprocess
import tempfile
import threading

AXISCALD = os.environ["AXISCALD"]
AXISCAL = os.environ["AXISCAL"]
SOURCE = pathlib.Path(os.environ["AXISCAL_SOURCE"])
EXAMPLE = SOURCE / "deploy/examples/integrex"
MACHINE = "integrex-i200"
RUNS = ("short-run1", "long-run1", "short-run2", "long-run2")

# What the shell of whoever runs the tests says about other servers is not for them.
for _name in list(os.environ):
    if _name.startswith("AXISCAL_") and _name != "AXISCAL_SOURCE":
        del os.environ[_name]


class Folder:
    """A temporary folder that is removed at the end."""

    def __init__(self):
        self.path = pathlib.Path(tempfile.mkdtemp(prefix="axiscal-python-"))

    def __enter__(self):
        return self.path

    def __exit__(self, *_):
        shutil.rmtree(self.path)


class Server:
    """A server on a database; listens on a free port, or on the address it is given. Stopped by leaving it."""

    def __init__(self, database, *flags, listen="127.0.0.1:0"):
        self.database = database
        self._flags = flags
        self._listen = listen

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, *_):
        self.stop()

    def start(self):
        with open(f"{self.database}.log", "ab") as log:
            self.process = subprocess.Popen([AXISCALD, "--db", str(self.database), "--listen", self._listen, *self._flags],
                                            stdout=subprocess.PIPE, stderr=log, text=True)
        line = self.process.stdout.readline()
        if not line.startswith("axiscald listens on "):
            self.process.wait()
            raise RuntimeError(f"axiscald did not start: {pathlib.Path(f'{self.database}.log').read_text()}")
        self.address = line.split()[-1]
        self._listen = self.address  # again at the same place when it is started again

    def stop(self):
        if self.process.poll() is None:
            self.process.terminate()
        self.process.wait()
        self.process.stdout.close()

    def kill(self):
        self.process.kill()
        self.stop()


class CuttingProxy:
    """Passes bytes between a client and a server, and cuts the first connections after so many bytes from the client."""

    def __init__(self, server_address, cuts):
        host, _, port = server_address.rpartition(":")
        self._server = (host, int(port))
        self._cuts = list(cuts)
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.address = "127.0.0.1:%d" % self._listener.getsockname()[1]
        self.was_cut = 0
        threading.Thread(target=self._accept, daemon=True).start()

    def close(self):
        self._listener.shutdown(socket.SHUT_RDWR)  # wakes accept()
        self._listener.close()

    def _accept(self):
        while True:
            try:
                client, _ = self._listener.accept()
            except OSError:
                return
            limit = self._cuts.pop(0) if self._cuts else None
            threading.Thread(target=self._connect, args=(client, limit), daemon=True).start()

    def _connect(self, client, limit):
        with client, socket.create_connection(self._server) as server:
            back = threading.Thread(target=self._pass, args=(server, client, None), daemon=True)
            back.start()
            self._pass(client, server, limit)
            back.join()

    def _pass(self, source, sink, limit):
        passed = 0
        try:
            while True:
                data = source.recv(4096)
                if not data:
                    break
                passed += len(data)
                if limit is not None and passed > limit:
                    self.was_cut += 1
                    break
                sink.sendall(data)
        except OSError:
            pass
        for end in (source, sink):
            try:
                end.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass


def axiscal(*words, check=True):
    """The command line."""
    return subprocess.run([AXISCAL, *map(str, words)], check=check, capture_output=True, text=True)


def json_of(*words):
    return json.loads(axiscal("--json", *words).stdout)
