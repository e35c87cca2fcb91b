# names: the remedies, which are columns of the table too; runs of each place; jerk_limit of joint 1, rad/s^3
@canvas 1000,870
set multiplot layout 3,2 title sprintf('Probability of an abort in 1 s of joint 1 (%d runs in each cell)', runs) @heading
do for [i = 1:5] {
  @panel
  set title names[i]
  set xlabel 'jitter, standard deviation [us]'
  set ylabel 'peak speed [rad/s]'
  set cblabel 'aborted'
  set cbrange [0:1]
  set rmargin 15
  set logscale x
  set autoscale yfix
  # The third difference of white samples has sqrt(20) times their deviation.
  plot $data using 1:2:($1/sqrt(2)):($1*sqrt(2)):($2 - 0.125):($2 + 0.125):(column(names[i])) @cells, \
    $data using (i == 1 ? 1e6*jerk_limit*1e-9/sqrt(20)/$2 : NaN):2 @dashed lc rgb RA \
    title i == 1 ? 'RMS jerk = limit' : ''
}
