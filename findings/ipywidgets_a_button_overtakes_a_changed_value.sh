#!/usr/bin/env bash
# A panel in a notebook has a field and a button. You expect that the kernel learns what a person did in the order in
# which they did it. @jupyter-widgets/base 6.0.11, which JupyterLab's widgets are made of, keeps a changed value back
# while the kernel works on an earlier change of the same widget, but sends a click at once. Seen: with the field set
# to A and then to B and the button clicked, the messages are "text A", "button click", "text B". On a slow computer
# the click therefore acts on the value before, for example on the pixel that was clicked before.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm init --yes >/dev/null
npm install --silent @jupyter-widgets/base@6.0.11 jsdom@24.1.3 esbuild@0.21.5 >/dev/null
echo 'export { WidgetModel } from "@jupyter-widgets/base";' >entry.js
node_modules/.bin/esbuild entry.js --bundle --platform=node --outfile=widgets.cjs --loader:.css=empty --log-level=error
cat >run.js <<'JAVASCRIPT'
const { JSDOM } = require("jsdom");
const { window } = new JSDOM("<body></body>", { pretendToBeVisual: true, url: "http://localhost/" });
for (const key of Object.getOwnPropertyNames(window)) if (!(key in globalThis)) globalThis[key] = window[key];
for (const key of ["window", "document", "navigator"])
  Object.defineProperty(globalThis, key, { value: key === "window" ? window : window[key], configurable: true });
globalThis.DragEvent ??= class {};
const { WidgetModel } = require("./widgets.cjs");

const sent = [], answers = [];
const widget_manager = { callbacks: () => ({}) };
const model = (name) => new WidgetModel({}, { model_id: name, widget_manager, comm: {
  comm_id: name, on_msg() {}, on_close() {},
  send(data, callbacks) {
    sent.push(`${name} ${data.method === "update" ? data.state.value : data.content.event}`);
    answers.push(callbacks?.iopub?.status);
    return String(sent.length);
  } } });
const text = model("text"), button = model("button");
const type = (value) => { text.set("value", value); text.save_changes(text.callbacks()); };

type("A");  // the kernel begins to work on it
type("B");
button.send({ event: "click" }, button.callbacks());
const meanwhile = sent.join(", ");
for (const done of answers.splice(0)) done?.({ content: { execution_state: "idle" } });
console.log(`while the kernel works: ${meanwhile}`);
console.log(`when it has finished:   ${sent.join(", ")}`);
process.exit(meanwhile === "text A, button click" && sent[2] === "text B" ? 0 : 1);
JAVASCRIPT
node run.js
