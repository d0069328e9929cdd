"""Unpacks an SSP and validates its XML files against the schemas of SSP 1.0 that FMPy ships.

usage: validate_ssp.py FILE.ssp FOLDER
"""
import sys
import zipfile
from pathlib import Path

import fmpy.ssp
from lxml import etree

SCHEMAS = {".ssd": "SystemStructureDescription.xsd", ".ssv": "SystemStructureParameterValues.xsd"}

file, folder = sys.argv[1:]
zipfile.ZipFile(file).extractall(folder)
schemas = Path(fmpy.ssp.__file__).parent / "schema"
for path in sorted(Path(folder).rglob("*")):
    if path.suffix in SCHEMAS:
        found = list(schemas.rglob(SCHEMAS[path.suffix]))
        schema = etree.XMLSchema(etree.parse(str(found[0])))
        schema.assertValid(etree.parse(str(path)))
        print("valid:", path.relative_to(folder))
