// Fits off the page's own thread, which stays answerable; to cancel, the page ends us.
"use strict";
onmessage = async ({ data: { module, files, asked } }) => {
  const reader = new FileReaderSync();
  let told = 0;
  let words = "";
  let exports;
  let litter;
  const bytes = (at, length) => new Uint8Array(exports.memory.buffer, at >>> 0, length);
  const page = {
    read(place, offset, into, length) {
      const file = files[place];
      const now = performance.now();
      if (now - told > 100) {
        told = now;
        postMessage({ reading: file.name, offset, length: file.size });
      }
      try {
        // A string, for the buffers that readAsArrayBuffer makes are not given back as long as we work: 2 GB of them for 2 GB.
        const slice = reader.readAsBinaryString(file.slice(offset, offset + length));
        const room = bytes(into, slice.length);
        for (let at = 0; at < slice.length; at++) room[at] = slice.charCodeAt(at);
        // Strings are given back when young objects have filled their space, which by themselves they hardly do: until then
        // slices of 256 kB stay, and with a litter of 16 kB each they were 100 MB and more.
        litter = new Array(8192).fill(0.5);
        return slice.length;
      } catch {
        return -1;
      }
    },
    failed(text, length) {
      words = new TextDecoder().decode(bytes(text, length));
    },
  };
  try {
    exports = (await WebAssembly.instantiate(module, { page })).exports;
    const request = new TextEncoder().encode(JSON.stringify(asked));
    const room = exports.request(request.length);
    bytes(room, request.length).set(request);
    exports.fit();
    const text = new TextDecoder().decode(bytes(exports.answer(), exports.answer_length()));
    postMessage({ answer: JSON.parse(text), memory: exports.memory.buffer.byteLength });
  } catch (error) {
    postMessage({ answer: { error: `the program failed, which it should not: ${words || error}` } });
  }
};
