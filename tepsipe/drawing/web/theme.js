// before anything is drawn: the reader's choice between light and dark, kept where the browser allows it
try {
  const chosen = localStorage.getItem("tepsipe-theme");
  if (chosen) document.documentElement.dataset.theme = chosen;
} catch { /* no storage for pages from a file: the system's choice */ }
// the button that changes it, on every page
document.addEventListener("click", (event) => {
  if (!event.target.closest("#theme")) return;
  const root = document.documentElement;
  const dark = root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  root.dataset.theme = dark ? "light" : "dark";
  try { localStorage.setItem("tepsipe-theme", root.dataset.theme); } catch { /* no storage for files */ }
});
