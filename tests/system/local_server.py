"""A web server on this machine, for tests of downloads."""

import contextlib
import functools
import http.server
import threading


@contextlib.contextmanager
def serving(handler):
    """Yield the address of a server that answers by ``handler`` while the block runs."""
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as running:
        thread = threading.Thread(target=functools.partial(running.serve_forever, poll_interval=0.01))
        thread.start()
        yield f"http://127.0.0.1:{running.server_address[1]}"
        running.shutdown()
        thread.join()
