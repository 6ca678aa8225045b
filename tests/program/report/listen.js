// Runs before anything else: collects what goes wrong.
"use strict";
window.errors = [];
addEventListener("error", (event) => window.errors.push(event.message));
addEventListener("unhandledrejection", (event) => window.errors.push(String(event.reason)));
for (const kind of ["error", "warn"])
  console[kind] = (...said) => window.errors.push(said.join(" "));
