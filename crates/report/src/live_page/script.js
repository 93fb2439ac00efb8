"use strict";
// Parts come as events: the id of a part in the first line, its HTML in the others.
(() => {
  const line = document.getElementById("line");
  const tell = text => { if (line.textContent !== text) line.textContent = text; };
  const clock = () => new Date().toLocaleTimeString();
  let source, page = null, heard = null;
  const open = () => {
    source = new EventSource("events" + location.search);
    source.onmessage = event => {
      const end = event.data.indexOf("\n");
      const part = document.getElementById(event.data.slice(0, end));
      if (part) part.innerHTML = event.data.slice(end + 1);
      heard = clock();
      tell("Connected.");
    };
    // Another run is served where this page's was: it has a page of its own.
    source.addEventListener("page", event => { if (page !== null && page !== event.data) location.reload(); page = event.data; });
    source.addEventListener("over", () => { source.close(); tell("It is over; what is shown is the last."); });
    source.onerror = () => {
      // A token is a start's own.
      const anew = location.search ? " A program that was started anew has a new address, which it prints." : "";
      tell(heard ? `The connection is lost; what is shown is from ${heard}. It is being opened again.${anew}` : `Nobody answers yet.${anew}`);
      // The browser tries again by itself, unless the answer was none that it knows.
      if (source.readyState === EventSource.CLOSED) setTimeout(open, 3000);
    };
  };
  open();
})();
