/PROG  MOTIONS
/ATTR
OWNER		= MNEDITOR;
DEFAULT_GROUP	= 1,*,*,*,*;
/MN
   1:  R[4]=30 ;
   2:  R[5]=120 ;
   3:  R[1]=3 ;
   4:  R[2]=20 ;
   5:J P[1:"here"] 100% FINE ;
   6:J P[3] 2.5sec CNT0 ;
   7:J P[3] 750msec FINE ;
   8:L P[2] 250mm/sec CNT50 ;
   9:L P[1] 600cm/min CNT100 ACC80 ;
  10:L P[1] 60.0inch/min FINE ;
  11:L P[1] 45deg/sec FINE ;
  12:L P[2] 1.5sec FINE PTH ;
  13:C P[1]    
    :  P[2] 100mm/sec CNT R[4:cnt] ;
  14:L P[2] 100mm/sec FINE Wjnt ACC R[5] ;
  15:J P[R[1]] R[2]% FINE ;
  16:  PR[R[1]]=LPOS ;
  17:L PR[R[1]] 50mm/sec FINE INC ;
/POS
P[1:"here"]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X = 900.000 mm,	Y = 0.000 mm,	Z = 700.000 mm,
	W = 180.000 deg,	P = 0.000 deg,	R = 0.000 deg
};
P[2:"here"]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'F U T, 0, 0, -1',
	X = 800.000 mm,	Y = 100.000 mm,	Z = 600.000 mm,
	W = 180.000 deg,	P = 0.000 deg,	R = 0.000 deg
};
P[3]{
   GP1:
	UF : F, UT : F,
	J1 = 10.000 deg,	J2 = 20.000 deg,	J3 = -30.000 deg,	J4 = 0.000 deg,	J5 = -60.000 deg,	J6 = 5.000 deg
};
/END
