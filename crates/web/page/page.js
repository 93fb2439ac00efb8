"use strict";
const element = id => document.getElementById(id);
const form = element("asked");
let chosen = [];
let worker = null;
let saved = [];
// Whoever tests the page reads here what was answered.
globalThis.answered = null;

const module = (async () => {
  const packed = Uint8Array.from(atob(element("packed").textContent), letter => letter.charCodeAt(0));
  element("packed").remove();
  const unpacked = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return WebAssembly.compile(await new Response(unpacked).arrayBuffer());
})();
const workerAddress = URL.createObjectURL(new Blob([element("worker").textContent], { type: "text/javascript" }));

const size = bytes => bytes < 1e6 ? `${Math.ceil(bytes / 1e3)} kB` : bytes < 1e9 ? `${(bytes / 1e6).toFixed(0)} MB`
  : `${(bytes / 1e9).toFixed(2)} GB`;

// What is said names parameters, each of which is a field here.
function field(name) {
  const label = form.elements.namedItem(name)?.labels[0];
  const text = [...label?.childNodes ?? []].find(node => node.nodeType === Node.TEXT_NODE && node.data.trim());
  return text && `“${text.data.trim()}”`;
}

const told = sentence => sentence.replace(/`(\w+)`/g, (all, name) => field(name) ?? all);

function show(part) {
  for (const id of ["work", "failure", "result"]) element(id).hidden = id !== part;
}

function stop() {
  worker?.terminate();
  worker = null;
}

function fail(sentence) {
  stop();
  element("failure").textContent = told(sentence);
  show("failure");
}

async function fit() {
  if (!chosen.length) return;
  stop();
  globalThis.answered = null;
  element("again").hidden = false;
  element("doing").textContent = "Getting ready";
  element("bar").removeAttribute("value");
  show("work");
  const asked = { files: chosen.map(({ name, size }) => ({ name, length: size })) };
  for (const [name, value] of new FormData(form)) asked[name] = name === "allow_narrow" ? true : value;
  const mine = new Worker(workerAddress);
  worker = mine;
  let quiet;
  mine.onerror = event => fail(`The browser cannot run this page: ${event.message}: take a newer one.`);
  mine.onmessage = ({ data }) => {
    if (mine !== worker) return;
    clearTimeout(quiet);
    if (data.answer) return answer(data);
    element("doing").textContent = `Reading ${data.reading}: ${size(data.offset)} of ${size(data.length)}`;
    element("bar").value = data.length ? data.offset / data.length : 0;
    quiet = setTimeout(() => {
      element("doing").textContent = "Fitting";
      element("bar").removeAttribute("value");
    }, 1000);
  };
  try {
    mine.postMessage({ module: await module, files: chosen, asked });
  } catch (error) {
    fail(`The browser cannot run this page: ${error.message}: take a newer one.`);
  }
}

function answer(data) {
  stop();
  globalThis.answered = data;
  const { error, fitted } = data.answer;
  if (error !== undefined) return fail(error);
  element("notes").replaceChildren(...fitted.notes.map(note => {
    const line = document.createElement("li");
    line.textContent = told(note);
    return line;
  }));
  saved.forEach(URL.revokeObjectURL);
  saved = [];
  element("save").replaceChildren(...fitted.files.map(({ what, name, text }) => {
    const link = document.createElement("a");
    link.className = "save";
    link.download = name;
    link.href = URL.createObjectURL(new Blob([text]));
    saved.push(link.href);
    link.textContent = `Save the ${what}`;
    link.title = name;
    return link;
  }));
  const report = element("report");
  report.onload = () => {
    const page = report.contentDocument;
    // The page about it has its own edge.
    page.body.style.padding = "1rem 0 0";
    for (const code of page.querySelectorAll("code")) code.replaceWith(field(code.textContent) ?? code);
    const grow = () => { report.style.height = `${page.documentElement.scrollHeight}px`; };
    new ResizeObserver(grow).observe(page.body);
    grow();
  };
  show("result");
  report.srcdoc = fitted.report;
  element("result").scrollIntoView({ behavior: "smooth", block: "start" });
}

function choose(files) {
  if (!files.length) return;
  chosen = [...files];
  element("drop").querySelector("span").textContent = chosen.map(file => file.name).join(", ");
  fit();
}

element("files").addEventListener("change", event => {
  choose(event.target.files);
  // So that the same one can be chosen again.
  event.target.value = "";
});
element("cancel").addEventListener("click", () => { stop(); show(""); });
form.addEventListener("submit", event => { event.preventDefault(); fit(); });
for (const kind of ["dragover", "drop", "dragleave"]) {
  addEventListener(kind, event => {
    event.preventDefault();
    element("drop").classList.toggle("over", kind === "dragover");
    if (kind === "drop") choose(event.dataTransfer.files);
  });
}
