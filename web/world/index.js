import { Shell } from "./shell.js";

// anywidget calls this for every place in which the widget is shown.
function render({ model, el }) {
  const shell = new Shell(model, el);
  return () => shell.close();
}

export default { render };
