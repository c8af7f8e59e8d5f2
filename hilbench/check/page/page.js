"use strict";
(() => {
  const rows = [...document.querySelectorAll("details.row")];
  const texts = rows.map(row => row.textContent.toLowerCase());
  const search = document.getElementById("search"), count = document.getElementById("count");
  const words = [...document.querySelectorAll("button[data-word]")], changed = document.getElementById("changed");
  const pressed = button => button !== null && button.getAttribute("aria-pressed") === "true";
  const filter = () => {
    const wanted = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    const chosen = words.filter(pressed).map(button => `|${button.dataset.word}|`);
    let shown = 0;
    rows.forEach((row, at) => {
      const fits = wanted.every(word => texts[at].includes(word))
        && (chosen.length === 0 || chosen.some(word => row.dataset.words.includes(word)))
        && (!pressed(changed) || "changed" in row.dataset);
      row.hidden = !fits;
      shown += fits;
    });
    count.textContent = `${shown} of ${rows.length}`;
  };
  search.addEventListener("input", filter);
  for (const button of [...words, changed].filter(Boolean))
    button.addEventListener("click", () => {
      button.setAttribute("aria-pressed", String(!pressed(button)));
      filter();
    });
  for (const row of rows)
    row.addEventListener("toggle", () => {
      for (const lines of row.querySelectorAll(".lines")) lines.scrollTop = lines.scrollHeight;
    });
  const bad = rows.filter(row => /\|(fail|error)\|/.test(row.dataset.words));
  if (bad.length > 0 && bad.length <= 3) bad.forEach(row => { row.open = true; });
  filter();
})();
