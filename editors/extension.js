// Starts `cortexc lsp` and lets it answer for `.scn` files.
const { workspace } = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

exports.activate = async () => {
  const [command, ...args] = workspace.getConfiguration("cortexc").get("command");
  client = new LanguageClient("cortexc", "cortexc", { command, args }, { documentSelector: [{ language: "scn" }] });
  await client.start();
};

exports.deactivate = () => client && client.stop();
