/* A table that is sorted by the columns whose headings are clicked, empty cells last. */

const words = new Intl.Collator("en", { numeric: true });

function sort(table, head, column) {
  const down = head.getAttribute("aria-sort") === "ascending", sign = down ? -1 : 1, body = table.tBodies[0];
  const rows = [...body.rows].sort((a, b) => {
    const p = a.cells[column].textContent, q = b.cells[column].textContent;
    if (p === "" || q === "") return (p === "") - (q === "");
    const x = Number(p), y = Number(q);
    return sign * (Number.isNaN(x) || Number.isNaN(y) ? words.compare(p, q) : x - y);
  });
  for (const other of table.tHead.rows[0].cells) other.setAttribute("aria-sort", "none");
  head.setAttribute("aria-sort", down ? "descending" : "ascending");
  body.replaceChildren(...rows);
}

for (const table of document.querySelectorAll(".sortable table")) {
  [...table.tHead.rows[0].cells].forEach((head, k) => {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    button.addEventListener("click", () => sort(table, head, k));
    head.append(button);
    head.setAttribute("aria-sort", "none");
  });
}
window.ready = Promise.resolve(true);
