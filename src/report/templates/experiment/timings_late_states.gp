@canvas 1040,320
set multiplot layout 1,2
do for [varied = 0:1] {
  @panel
  set title varied == 0 ? 'share of late states' : 'delay of late states'
  set xlabel varied == 0 ? 'weight of the late bin [%]' : 'begin of the late bin [us]'
  set ylabel 'unserved cycles [%]'
  set logscale y
  set yrange [0.01:20]
  plot for [loop in 'LF RS RA'] $data using (of(1, varied, "value")):(column(loop.' unserved [%]')) @line lc rgb value(loop) title loop
}
