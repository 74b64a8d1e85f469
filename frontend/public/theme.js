// Sets the chosen theme before the first paint; without a choice the system's is used.
(function () {
  var theme = null;
  try {
    theme = localStorage.getItem("tril.theme");
  } catch (error) {
    // Storage is closed: the system's theme stays.
  }
  if (theme === "light" || theme === "dark") document.documentElement.dataset.theme = theme;
})();
