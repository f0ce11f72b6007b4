"""What the document type of UPPAAL's flat system 1.6 asks of an XML file, written out as a check.

A content model is a regular expression over the names of the children. Places and identifiers are checked
besides: every drawable element has whole coordinates, every reference an identifier in its template.
"""

from __future__ import annotations

import re
from xml.etree import ElementTree as ET

CONTENTS = {
    "nta": "(imports )?(declaration )?(template )+(instantiation )?system (queries )?",
    "template": "name (parameter )?(declaration )?(location )*(branchpoint )*(init )?(transition )*",
    "location": "(name )?(label )*((urgent )|(committed ))?",
    "transition": "source target (label )*(nail )*",
    "queries": "(query )*",
    "query": "formula comment ",
}
EMPTY = {"init", "source", "target", "nail", "urgent", "committed"}
TEXT = {"declaration", "name", "label", "system", "formula", "comment", "parameter", "instantiation"}
ATTRIBUTES = {
    "nta": set(),
    "location": {"id", "x", "y"},
    "init": {"ref"},
    "source": {"ref"},
    "target": {"ref"},
    "nail": {"x", "y"},
    "label": {"kind", "x", "y"},
    "name": {"x", "y"},
}
KINDS = {"location": ["invariant"], "transition": ["guard", "synchronisation", "assignment"]}
IDENTIFIER = re.compile(r"[A-Za-z_]\w*", re.ASCII)
DOCTYPE = (
    "<!DOCTYPE nta PUBLIC '-//Uppaal Team//DTD Flat System 1.6//EN' "
    "'http://www.it.uu.se/research/group/darts/uppaal/flat-1_6.dtd'>"
)


def faults(text: str) -> list[str]:
    """Everything that is wrong with the file; nothing if it is as it should be."""
    lines = text.splitlines()
    found = [] if lines[1] == DOCTYPE else ["the second line is not the document type"]
    root = ET.fromstring(text)  # noqa: S314
    for element in root.iter():
        found += _element_faults(element)
    identities: list[str] = []
    for template in root.findall("template"):
        own = [location.get("id", "") for location in template.findall("location")]
        identities += own
        found += _reference_faults(template, own)
        names = [name.text or "" for name in template.findall("location/name")]
        found += [f"{name} is no identifier" for name in names if not IDENTIFIER.fullmatch(name)]
        found += [f"the name {name} occurs twice" for name in set(names) if names.count(name) > 1]
    if identities != [f"id{number}" for number in range(len(identities))]:
        found.append("the ids are not id0, id1 and so on")
    return found


def _element_faults(element: ET.Element) -> list[str]:
    children = "".join(f"{child.tag} " for child in element)
    found = []
    if element.tag in CONTENTS:
        if not re.fullmatch(CONTENTS[element.tag], children):
            found.append(f"{element.tag} contains {children}")
    elif element.tag not in EMPTY | TEXT:
        found.append(f"there is no element {element.tag}")
    elif children or (element.tag in EMPTY and (element.text or "").strip()):
        found.append(f"{element.tag} is not empty")
    wanted = ATTRIBUTES.get(element.tag)
    if wanted is not None and set(element.keys()) - {"x", "y"} != wanted - {"x", "y"}:
        found.append(f"{element.tag} has the attributes {sorted(element.keys())}")
    if element.tag in {"location", "nail", "label"}:
        found += [
            f"{element.tag} has no {axis}"
            for axis in "xy"
            if not re.fullmatch(r"-?\d+", element.get(axis, ""))
        ]
    if element.tag in KINDS:
        kinds = [label.get("kind", "") for label in element.findall("label")]
        if kinds != [kind for kind in KINDS[element.tag] if kind in kinds]:
            found.append(f"{element.tag} has labels {kinds}")
    return found


def _reference_faults(template: ET.Element, own: list[str]) -> list[str]:
    references = [
        template.find("init"),
        *template.findall("transition/source"),
        *template.findall("transition/target"),
    ]
    return [
        f"{reference.tag} refers to {reference.get('ref')}"
        for reference in references
        if reference is not None and reference.get("ref") not in own
    ]
