# SPDX-License-Identifier: GPL-3.0-or-later
"""Serves a folder at 127.0.0.1 and prints the port: serve.py FOLDER"""

import functools
import http.server
import sys

handler = functools.partial(http.server.SimpleHTTPRequestHandler, directory=sys.argv[1])
server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
print(server.server_port, flush=True)
server.serve_forever()
