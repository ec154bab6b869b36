// Run a Python file on pyodide's CPython: node run_python.mjs PROJECT FILE. The project is read at /project.
import { readFileSync } from "node:fs";
import { loadPyodide } from "pyodide";

const [project, file] = process.argv.slice(2);
const pyodide = await loadPyodide();
pyodide.FS.mkdirTree("/project");
pyodide.FS.mount(pyodide.FS.filesystems.NODEFS, { root: project }, "/project");
try {
  pyodide.runPython("import sys; sys.path.insert(0, '/project')");
  pyodide.runPython(readFileSync(file, "utf8"));
} catch (error) {
  console.error(error.message);
  process.exitCode = 1;
}
