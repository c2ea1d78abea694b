/* The table of runs: a heading sorts by its column, empty cells last. */

const table = document.getElementById("runs"), words = new Intl.Collator("en", { numeric: true });

function sort(head, column) {
  const down = head.getAttribute("aria-sort") === "ascending", sign = down ? -1 : 1, body = table.tBodies[0];
  const value = (row) => row.cells[column].dataset.value ?? row.cells[column].textContent;
  const rows = [...body.rows].sort((a, b) => {
    const p = value(a), q = value(b);
    if (p === "" || q === "") return (p === "") - (q === "");
    const x = Number(p), y = Number(q);
    return sign * (Number.isNaN(x) || Number.isNaN(y) ? words.compare(p, q) : x - y);
  });
  for (const other of table.tHead.rows[0].cells) other.setAttribute("aria-sort", "none");
  head.setAttribute("aria-sort", down ? "descending" : "ascending");
  body.replaceChildren(...rows);
}

if (table) [...table.tHead.rows[0].cells].forEach((head, k) => head.querySelector("button").addEventListener("click", () => sort(head, k)));
window.ready = Promise.resolve(true);
