# names: the command chains; then the label of the x axis and the title. completed_0 ... completed_2: cases with a completed run, by pace.
label = names[6]
array paces[3] = ['canonical', 'brisk', 'hard']
at(pace, chain) = column("tempo [-]") == pace && column("way [-]") == chain ? column(label) : NaN
@canvas 1000,930
set multiplot layout 3,2 title names[7] @heading
do for [pace = 0:2] {
  @panel
  set title paces[pace + 1].': aborted'
  set xlabel label
  set ylabel '[%]'
  set logscale x
  set yrange [-5:105]
  plot for [chain = 0:4] $data using (at(pace, chain)):"aborted [%]" @line lc rgb series(chain + 1) title pace == 0 ? names[chain + 1] : ''
  @panel
  set title paces[pace + 1].': error of the completed'
  set xlabel label
  set ylabel '[mrad]'
  set logscale xy
  # Without a point gnuplot finds no range, and fails.
  if (value(sprintf('completed_%d', pace)) == 0) { set yrange [0.1:1] }
  plot for [chain = 0:4] $data using (at(pace, chain)):"RMS error [mrad]" @line lc rgb series(chain + 1) notitle
}
