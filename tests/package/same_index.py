# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether our index.json says what Blender's server-generate says of the same zips: same_index.py OURS BLENDERS"""

import json
import sys
from pathlib import Path

ours, theirs = (json.loads(Path(path).read_text()) for path in sys.argv[1:3])
wrong = [f"{key}: {ours[key]} here, {theirs[key]} there" for key in ("version", "blocklist") if ours[key] != theirs[key]]
items = [{item["archive_url"]: item for item in index["data"]} for index in (ours, theirs)]
for url in sorted(set(items[0]) | set(items[1])):
    here, there = (each.get(url, {}) for each in items)
    wrong += [
        f"{url}: {key} is {here.get(key)} here, {there.get(key)} there"
        for key in sorted(set(here) | set(there)) if here.get(key) != there.get(key)
    ]  # fmt: skip
print("".join(f"FAIL: {line}\n" for line in wrong), end="")
print(f"{int(not wrong)} passed, {len(wrong)} failed")
sys.exit(bool(wrong))
