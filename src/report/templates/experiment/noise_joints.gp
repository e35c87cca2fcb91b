# names: the stages
@canvas 1000,810
set multiplot layout 3,2 title 'Share of runs of 1 s that each joint alone aborts, by noise amplitude' @heading
do for [stage = 0:5] {
  @panel
  set title names[stage + 1]
  set logscale x
  set xlabel 'amplitude [rad]'
  set ylabel 'aborted'
  set yrange [-0.05:1.05]
  plot for [j = 1:7] $data using (of("stage", stage, "amplitude [rad]")):(column(sprintf("joint %d aborted", j))) \
    @line lc rgb series(j) title stage == 0 ? sprintf('joint %d', j) : ''
}
