"""The OpenAPI document as one page of HTML without a script, so that it needs nothing from elsewhere."""

from __future__ import annotations

import json
import re
from html import escape
from typing import Any

CONTENT_SECURITY_POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)

_STYLE = """
:root{color-scheme:light dark;--line:#8885;--dim:#888;--get:#2a7;--post:#37c;--patch:#a70;--delete:#c44;--head:#777}
body{font:15px/1.55 system-ui,sans-serif;max-width:60rem;margin:0 auto;padding:2rem 1rem 6rem}
h1{font-size:1.8rem}h2{margin-top:3rem;border-bottom:1px solid var(--line)}
code,pre{font:13px/1.45 ui-monospace,monospace}pre{overflow:auto;padding:.7rem;border:1px solid var(--line)}
details{border:1px solid var(--line);border-radius:6px;margin:.5rem 0;padding:.5rem .8rem}
summary{cursor:pointer}summary b{display:inline-block;min-width:4.5rem;text-transform:uppercase}
.get{color:var(--get)}.post{color:var(--post)}.patch{color:var(--patch)}.delete{color:var(--delete)}
.head,.options{color:var(--head)}.dim{color:var(--dim)}
table{border-collapse:collapse;width:100%}td,th{text-align:left;vertical-align:top;padding:.25rem .6rem .25rem 0}
td{border-top:1px solid var(--line)}nav a{margin-right:1rem}
"""


def render(document: dict[str, Any]) -> str:
    """Return the page that describes `document`."""
    info = document["info"]
    by_tag: dict[str, list[str]] = {tag["name"]: [] for tag in document["tags"]}
    for path, operations in document["paths"].items():
        for method, operation in operations.items():
            for tag in operation.get("tags", ()):
                by_tag[tag].append(_operation(method, path, operation))
    sections = "".join(
        f'<h2 id="{escape(tag["name"])}">{escape(tag["name"])}</h2><p>{_text(tag["description"])}</p>'
        + "".join(by_tag[tag["name"]])
        for tag in document["tags"]
        if by_tag[tag["name"]]
    )
    models = "".join(
        f'<details id="{escape(name)}"><summary><code>{escape(name)}</code></summary>'
        f"<p>{_text(schema.get('description', ''))}</p>{_code(schema)}</details>"
        for name, schema in sorted(document["components"]["schemas"].items())
    )
    links = "".join(
        f'<a href="#{escape(name)}">{escape(name)}</a>'
        for name in [*by_tag, "models"]
        if name == "models" or by_tag[name]
    )
    return (
        '<!doctype html><html lang="en"><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(info['title'])} {escape(info['version'])}: HTTP</title><style>{_STYLE}</style>"
        f"<h1>{escape(info['title'])} <span class=dim>{escape(info['version'])}</span></h1>"
        f'{_paragraphs(info["description"])}<p>As a file: <a href="/openapi.json">openapi.json</a></p>'
        f'<nav>{links}</nav>{sections}<h2 id="models">models</h2>{models}</html>'
    )


def _operation(method: str, path: str, operation: dict[str, Any]) -> str:
    parts = [f"<p>{_text(operation.get('description', ''))}</p>"]
    parameters = operation.get("parameters", [])
    if parameters:
        rows = "".join(
            f"<tr><td><code>{escape(item['name'])}</code>{' *' if item.get('required') else ''}"
            f"<td class=dim>{escape(item['in'])}"
            f"<td>{_text(item.get('description', ''))}<td><code>{escape(_kind(item.get('schema', {})))}</code>"
            for item in parameters
        )
        parts.append(f"<table><tr><th>Parameter<th>In<th><th>{rows}</table>")
    for media_type, content in operation.get("requestBody", {}).get("content", {}).items():
        parts.append(f"<p>Body: <code>{escape(media_type)}</code> {_link(content.get('schema', {}))}</p>")
        examples = [example["value"] for example in content.get("examples", {}).values()]
        examples += [content["example"]] if "example" in content else []
        parts += [_code(example) for example in examples]
    rows = "".join(
        f"<tr><td><code>{escape(status)}</code><td>{_text(response.get('description', ''))}<td>"
        + ", ".join(_link(content.get("schema", {})) for content in response.get("content", {}).values())
        for status, response in operation["responses"].items()
    )
    parts.append(f"<table><tr><th>Answer<th><th>{rows}</table>")
    return (
        f'<details id="{escape(operation["operationId"])}"><summary><b class="{method}">{method}</b>'
        f"<code>{escape(path)}</code> <span class=dim>{escape(operation.get('summary', ''))}</span></summary>"
        + "".join(parts)
        + "</details>"
    )


def _kind(schema: dict[str, Any]) -> str:
    if "anyOf" in schema:
        return " | ".join(_kind(option) for option in schema["anyOf"] if option.get("type") != "null")
    if "$ref" in schema:
        return str(schema["$ref"]).rpartition("/")[2]
    return str(schema.get("format") or schema.get("type", ""))


def _link(schema: dict[str, Any]) -> str:
    if schema.get("type") == "array":
        return f"list of {_link(schema['items'])}"
    if "$ref" in schema:
        name = str(schema["$ref"]).rpartition("/")[2]
        return f'<a href="#{escape(name)}"><code>{escape(name)}</code></a>'
    return f"<code>{escape(_kind(schema))}</code>"


def _text(markdown: str) -> str:
    """Return one paragraph; of Markdown only code and emphasis occur in our descriptions."""
    text = escape(markdown, quote=False)
    text = re.sub(r"`([^`]+)`", r"<code>\1</code>", text)
    text = re.sub(r"\*\*([^*]+)\*\*", r"<b>\1</b>", text)
    return re.sub(r"\*([^*\s][^*]*)\*", r"<i>\1</i>", text)


def _paragraphs(markdown: str) -> str:
    return "".join(
        f"<p>{_text(block).replace(chr(10), '<br>' if block[:1].isdigit() else ' ')}</p>"
        for block in markdown.strip().split("\n\n")
    )


def _code(value: Any) -> str:
    text = value if isinstance(value, str) else json.dumps(value, indent=2, ensure_ascii=False)
    return f"<pre>{escape(text, quote=False)}</pre>"
