import { Shell } from "./shell.js";

// anywidget imports this file once for each widget, and three.js would warn that it is there already.
delete window.__THREE__;

// anywidget calls this for every place in which the widget is shown.
function render({ model, el }) {
  const shell = new Shell(model, el);
  return () => shell.close();
}

export default { render };
