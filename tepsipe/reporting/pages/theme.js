// before anything is drawn: the reader's choice between light and dark, kept where the browser allows it
try {
  const chosen = localStorage.getItem("tepsipe-theme");
  if (chosen) document.documentElement.dataset.theme = chosen;
} catch { /* no storage for pages from a file: the system's choice */ }
