"""meta.toml beside a set of reference data: where it comes from, what its columns are, what it is for, and a digest of every file."""

import hashlib


def digest(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def write_meta(folder, title, source, role, consumers, channels, note=""):
    """channels: (column, unit, sign and meaning)."""
    q = lambda text: '"' + text.replace('"', '\\"') + '"'
    lines = [f"title = {q(title)}", f"source = {q(source)}", 'licence = "MIT OR Apache-2.0"', f"role = {q(role)}",
             f"consumers = [{', '.join(q(c) for c in consumers)}]"]
    if note:
        lines.append(f"accuracy = {q(note)}")
    for column, unit, sign in channels:
        lines += ["", "[[channel]]", f"name = {q(column)}", f"unit = {q(unit)}", f"sign = {q(sign)}"]
    lines += ["", "[sha256]"]
    lines += [f"{q(p.name)} = {q(digest(p))}" for p in sorted(folder.iterdir()) if p.is_file() and p.name != "meta.toml"]
    (folder / "meta.toml").write_text("\n".join(lines) + "\n")
