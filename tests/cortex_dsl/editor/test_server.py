"""The language server, asked by a real client over its standard streams."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from lsprotocol import types
from pygls.exceptions import JsonRpcException

from engine.extras import installing

BROKEN = ("EGO_SPEED     = Range(5, 80) km/h", "EGO_SPEED     = Range(80, 5) km/h")


def checked(path: Path) -> list[dict]:
    """Diagnostics of `--check`."""
    command = [sys.executable, "-m", "cortex_dsl", str(path), "--check", "--format", "json"]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    return json.loads(result.stdout)["diagnostics"]


def places(found: list[types.Diagnostic]) -> list[tuple]:
    return [(d.code, d.range.start.line + 1, d.range.start.character + 1) for d in found]


def test_a_right_file_is_quiet(talk, left_turn):
    async def conversation(client):
        client.open(left_turn)
        assert await client.diagnostics() == []

    talk(conversation)


def test_diagnostics_are_those_of_check(talk, left_turn, tmp_path):
    """Codes, places, severities and words; broken names and a broken line."""
    texts = [
        left_turn.replace(*BROKEN).replace("TERM_DIST\n", "TERM_DISTANCE\n"),
        left_turn.replace("with speed EGO_SPEED", "with sped EGO_SPEED") + "\nbehavior Idle():\n    wait\n",
        left_turn.replace("behavior EgoBehavior(trajectory):", "behavior EgoBehavior(trajectory:"),
        "# nothing here\n",
    ]

    async def conversation(client):
        path = tmp_path / "own.scn"
        for index, text in enumerate(texts):
            path.write_text(text)
            client.open(text) if index == 0 else client.change(text)
            found = await client.diagnostics()
            expected = checked(path)
            assert places(found) == [(d["code"], d["start"]["line"], d["start"]["column"]) for d in expected]
            assert expected
            for shown, known in zip(found, expected, strict=True):
                assert shown.severity == {"error": 1, "warning": 2, "note": 3, "hint": 4}[known["severity"]]
                assert known["message"] in shown.message
                assert known["cure"] in shown.message
                assert len(shown.related_information or ()) == len(known["secondary"])
                assert shown.source == "cortexc"

    talk(conversation)


def test_hover_shows_type_unit_range_and_doc(talk, left_turn):
    async def conversation(client):
        client.open(left_turn)

        async def said(marked, inside=0):
            position = client.at(marked, inside=inside)
            answer = await client.wait(
                client.ls.text_document_hover_async(types.HoverParams(client.document, position))
            )
            return answer.contents.value if answer else ""

        assert "a speed, 5 to 80 km/h (1.389 to 22.22 m/s)" in await said("EGO_SPEED ")
        assert "a length, 70 m" in await said("TERM_DIST = ")
        assert "Follow the trajectory" in await said("EgoBehavior(egoT")
        assert "0.277778 m/s" in await said("km/h")
        assert "target_speed" in await said("FollowTrajectoryBehavior(")
        assert "Speed at the start" in await said("with speed", 6)
        assert "a lane, one of `north.in.1`" in await said("egoInitLane.center")
        assert "Interrupts the `try`" in await said("interrupt when")
        assert await said("LTAP") == ""

    talk(conversation)


COMPLETIONS = [
    ("x = new ", {"Car", "OrientedPoint"}, {"speed", "ego"}),
    ("x = new Car at egoSpawnPt, with ", {"speed", "behavior", "viewAngle"}, {"Car"}),
    ("x = 5 ", {"m", "km/h", "m/s^2"}, {"ego"}),
    ("x = egoInitLane.", {"centerline", "maneuvers"}, {"startLane", "speed"}),
    ("x = Uniform(*egoManeuver.reverseManeuvers).", {"startLane"}, {"centerline"}),
    ("x = ManeuverType.", {"STRAIGHT", "U_TURN"}, {"centerline"}),
    ("x = globalParameters.", {"EGO_SPEED"}, {"centerline"}),
    ("", {"param", "require", "behavior", "terminate when"}, {"take"}),
    ("behavior B():\n    ", {"take", "do", "wait", "try"}, {"param"}),
    ("x = FollowTrajectoryBehavior(", {"target_speed=", "trajectory=", "EGO_SPEED"}, {"take"}),
    ("signals(", {"green=", "offset="}, {"take"}),
    ("x = (", {"EGO_SPEED", "egoInitLane", "Range", "abs", "distance from"}, {"take", "with"}),
    ("# ego.", set(), {"speed"}),
]
"""A line that is being written, what is offered there, and what is not."""


def test_completion_fits_the_place(talk, left_turn):
    async def conversation(client):
        client.open(left_turn)
        await client.diagnostics()
        for line, there, absent in COMPLETIONS:
            client.change(left_turn + line)
            params = types.CompletionParams(client.document, client.end())
            answer = await client.wait(client.ls.text_document_completion_async(params))
            labels = {item.label for item in answer}
            assert there <= labels, line
            assert not absent & labels, line
            explained = [item for item in answer if item.label in there & {"Car", "speed", "m", "param", "Range"}]
            assert all(item.documentation and item.detail for item in explained)

    talk(conversation)


def test_go_to_definition(talk, left_turn):
    async def conversation(client):
        client.open(left_turn)
        for used, inside, defined in [
            ("target_speed=EGO_SPEED", 13, "EGO_SPEED "),
            ("trajectory=trajectory)", 11, "trajectory):"),
            ("EgoBehavior(egoT", 0, "EgoBehavior(traj"),
            ("egoInitLane.maneuvers", 2, "egoInitLane "),
            ("m.type", 0, "m: m.type"),
            ("> TERM_DIST", 2, "TERM_DIST ="),
        ]:
            params = types.DefinitionParams(client.document, client.at(used, inside=inside))
            answer = await client.wait(client.ls.text_document_definition_async(params))
            assert answer is not None, used
            assert answer.range.start == client.at(defined), used

    talk(conversation)


def test_definition_in_an_imported_file(talk, tmp_path):
    cars = "class Taxi(Car):\n    speed: 5 m/s\n\nslow = 3 m/s\n"
    (tmp_path / "cars.scn").write_text(cars)
    main = "import cars\nfrom cars import Taxi as Cab, slow\nego = new Cab at (0, 0)\nx = slow + cars.slow\n"

    async def conversation(client):
        client.open(main)
        for used, inside, line in [("new Cab", 5, 0), ("= slow", 2, 3), ("cars.slow", 6, 3), ("import cars", 8, 0)]:
            params = types.DefinitionParams(client.document, client.at(used, inside=inside))
            answer = await client.wait(client.ls.text_document_definition_async(params))
            assert answer is not None, used
            assert (answer.uri.rsplit("/")[-1], answer.range.start.line) == ("cars.scn", line)

    talk(conversation)


def test_an_unsaved_import_counts(talk, tmp_path):
    """A file that another imports is read from the editor; after a change diagnostics of both are published."""
    (tmp_path / "cars.scn").write_text("slow = 3 m/s\n")

    async def conversation(client):
        client.open("from cars import slow\nego = new Car at (0, 0), with speed slow\n")
        codes = [d.code for d in await client.diagnostics()]
        cars = (tmp_path / "cars.scn").as_uri()
        document = types.TextDocumentItem(cars, "scn", 0, "slow = 3 kg\n")
        client.ls.text_document_did_open(types.DidOpenTextDocumentParams(document))
        while (shown := await client.wait(client.published.get())).uri == cars:
            pass
        assert [d.code for d in shown.diagnostics] != codes
        assert "SCN301" in [d.code for d in shown.diagnostics]

    talk(conversation)


def test_outline_references_and_rename(talk, left_turn):
    async def conversation(client):
        client.open(left_turn)
        symbols = await client.wait(
            client.ls.text_document_document_symbol_async(types.DocumentSymbolParams(client.document))
        )
        kinds = {symbol.name: symbol.kind for symbol in symbols}
        assert kinds["EGO_SPEED"] == types.SymbolKind.Constant
        assert kinds["EgoBehavior"] == types.SymbolKind.Function
        assert kinds["ego"] == types.SymbolKind.Object
        position = client.at("SAFETY_DIST")
        params = types.RenameParams(client.document, position, "NEAR")
        answer = await client.wait(client.ls.text_document_rename_async(params))
        (edits,) = answer.changes.values()
        assert len(edits) == left_turn.count("SAFETY_DIST") >= 2
        params = types.RenameParams(client.document, position, "require")
        with pytest.raises(JsonRpcException, match="is not a name"):
            await client.wait(client.ls.text_document_rename_async(params))

    talk(conversation)


def test_a_cure_is_one_click(talk, left_turn):
    """The edit of `did you mean` makes the file right again."""

    async def conversation(client):
        client.open(left_turn.replace("with speed EGO_SPEED", "with sped EGO_SPEED"))
        (wrong,) = [d for d in await client.diagnostics() if d.severity == types.DiagnosticSeverity.Error]
        context = types.CodeActionContext([wrong])
        params = types.CodeActionParams(client.document, wrong.range, context)
        (action,) = await client.wait(client.ls.text_document_code_action_async(params))
        assert action.title == "Write `speed`"
        ((edit,),) = action.edit.changes.values()
        assert (edit.new_text, edit.range) == ("speed", wrong.range)

    talk(conversation)


def test_formatting(talk, left_turn):
    async def conversation(client):
        client.open("x   =   1\n")
        params = types.DocumentFormattingParams(client.document, types.FormattingOptions(4, insert_spaces=True))
        (edit,) = await client.wait(client.ls.text_document_formatting_async(params))
        assert edit.new_text == "x = 1\n"
        client.change("x = (\n")
        assert not await client.wait(client.ls.text_document_formatting_async(params))

    talk(conversation)


def test_signature_of_what_is_called(talk, left_turn):
    async def conversation(client):
        client.open(left_turn + "x = FollowTrajectoryBehavior(5 m/s, ")
        params = types.SignatureHelpParams(client.document, client.end())
        answer = await client.wait(client.ls.text_document_signature_help_async(params))
        assert answer.active_parameter == 1
        assert "FollowTrajectoryBehavior(target_speed" in answer.signatures[0].label

    talk(conversation)


def test_it_stays_useful_while_the_text_is_broken(talk, left_turn):
    """Names of the last good tree, and no answer is an error."""

    async def conversation(client):
        client.open(left_turn)
        await client.diagnostics()
        client.change(left_turn.replace("TERM_DIST = 70 m", "TERM_DIST = = 70 m"))
        assert [d.severity for d in await client.diagnostics()] == [types.DiagnosticSeverity.Error]
        params = types.HoverParams(client.document, client.at("EGO_BRAKE)"))
        assert "0 to 1" in (await client.wait(client.ls.text_document_hover_async(params))).contents.value
        params = types.DefinitionParams(client.document, client.at("EGO_BRAKE)"))
        assert await client.wait(client.ls.text_document_definition_async(params)) is not None

    talk(conversation)


def test_only_the_last_of_many_changes_counts(talk, left_turn):
    """Nothing is published for superseded texts: the first diagnostics after a burst are those of its end."""

    async def conversation(client):
        client.open(left_turn)
        assert await client.diagnostics() == []
        for count in range(30):
            client.change(left_turn + "\ny = " + "(" * (count + 1))
        client.change(left_turn + "\nparam UNUSED = Range(0, 1)\n")
        assert [d.code for d in await client.diagnostics()] == ["SCN221"]
        assert client.published.empty()

    talk(conversation)


def test_columns_are_counted_as_the_client_counts(talk, left_turn):
    async def conversation(client):
        client.open('x = "\N{AUTOMOBILE}\N{AUTOMOBILE}" + TYPO\n')
        (wrong, *_) = [d for d in await client.diagnostics() if "TYPO" in d.message]
        assert wrong.range.start.character == 13

    talk(conversation)


def test_without_pygls_there_is_one_clear_line(tmp_path):
    (tmp_path / "sitecustomize.py").write_text(
        "import sys\n"
        "class Hide:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        "        if name.split('.')[0] in ('pygls', 'lsprotocol'):\n"
        "            raise ModuleNotFoundError(name, name=name)\n"
        "sys.meta_path.insert(0, Hide())\n"
    )
    command = [sys.executable, "-m", "cortex_dsl", "lsp"]
    environment = {"PYTHONPATH": str(tmp_path), "PATH": ""}
    result = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    assert result.returncode == 2
    message = "cortexc: the language server needs pygls, which is not installed"
    assert result.stderr == f"{message}\n  help: {installing('lsp')}\n"
    assert result.stdout == ""


def served(*messages: object) -> "subprocess.CompletedProcess[bytes]":
    """Send these messages to a server at once; return its exit code."""
    bodies = [json.dumps(message).encode() for message in messages]
    data = b"".join(b"Content-Length: %d\r\n\r\n%s" % (len(body), body) for body in bodies)
    return subprocess.run([sys.executable, "-m", "cortex_dsl", "lsp"], input=data, capture_output=True, check=False)


def test_what_is_not_open_is_said():
    """A question about a file that was never opened has a plain answer, and no traceback is printed."""
    question = {"textDocument": {"uri": "file:///a.scn"}, "position": {"line": 0, "character": 0}}
    start = {"jsonrpc": "2.0", "id": 1, "method": "initialize", "params": {"processId": None, "capabilities": {}}}
    done = served(start, {"jsonrpc": "2.0", "id": 2, "method": "textDocument/hover", "params": question}, [1, 2])
    assert b"`file:///a.scn` is not open" in done.stdout
    assert b"Traceback" not in done.stderr
    assert done.returncode == 0
