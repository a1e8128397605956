"""The style of HTML documents: for a screen, a phone and paper, with fonts that are there."""

CSS = """\
:root { color-scheme: light dark; --line: #8886; --soft: #8881; }
* { box-sizing: border-box; }
body { margin: 0; font: 1.05rem/1.55 Charter, "Bitstream Charter", Cambria, Georgia, serif; }
main { max-width: 60rem; margin: 0 auto; padding: 1.5rem 1rem 4rem; }
h1 { font-size: 1.8rem; line-height: 1.2; margin: 0.5rem 0 0.8rem; }
h2 { font-size: 1.35rem; margin: 2.6rem 0 0.6rem; padding-bottom: 0.2rem;
  border-bottom: 1px solid var(--line); }
h3 { font-size: 1.05rem; margin: 1.6rem 0 0.3rem; }
p { margin: 0.4rem 0 0.7rem; }
nav ol { margin: 0.5rem 0; padding-left: 1.4rem; }
.formula, .table { overflow: auto hidden; margin: 0.6rem 0; }
.formula { padding: 0.5rem 0.8rem; background: var(--soft); border-radius: 6px; }
table { border-collapse: collapse; }
th, td { text-align: left; vertical-align: baseline; padding: 0.25rem 0.9rem 0.25rem 0; }
td:not(:last-child) { white-space: nowrap; }
thead th { border-bottom: 1px solid var(--line); }
tbody tr + tr td { border-top: 1px solid var(--soft); }
math { font-family: "Latin Modern Math", "STIX Two Math", "Cambria Math", "Libertinus Math",
  "TeX Gyre DejaVu Math", "DejaVu Math TeX Gyre", math, serif; }
math[display="block"] { text-align: left; margin: 0; width: max-content; font-size: 0.95em; }
math + math { margin-top: 0.5rem !important; }
mtd { padding: 0.28em 0.5em; }
mtable.matrix { margin: 0 0.2em; padding: 0.1em 0.15em;
  background:
    linear-gradient(currentColor, currentColor) left top / 0.35em 1.5px no-repeat,
    linear-gradient(currentColor, currentColor) left bottom / 0.35em 1.5px no-repeat,
    linear-gradient(currentColor, currentColor) right top / 0.35em 1.5px no-repeat,
    linear-gradient(currentColor, currentColor) right bottom / 0.35em 1.5px no-repeat;
  background-origin: border-box;
  border-left: 1.5px solid; border-right: 1.5px solid; }
@media (max-width: 40rem) {
  body { font-size: 1rem; }
  main { padding: 0.8rem 0.7rem 3rem; }
  h1 { font-size: 1.4rem; }
  h2 { font-size: 1.2rem; }
}
@media print {
  @page { margin: 16mm; }
  :root { color-scheme: light; }
  html { font-size: 10pt; }
  body { font-size: 1rem; }
  main { max-width: none; padding: 0; }
  nav { display: none; }
  h2, h3 { break-after: avoid; }
  .formula { background: none; padding: 0 0 0 1rem; overflow: visible; }
  .formula, tr { break-inside: avoid; }
  mtable.matrix { -webkit-print-color-adjust: exact; print-color-adjust: exact; }
}
"""
